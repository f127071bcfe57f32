"""
Fig. 10: synthetic fire from six views
======================================

Inputs every 30 degrees; shown and scored half-way between them, at 15 degrees and so on.
"""

from common import compare

compare("fig10", (0, 30, 60, 90, 120, 150), (15, 45, 75), (15, 45, 75, 105, 135, 165))
