"""
Fig. 9: synthetic fire from a pair of views
===========================================

Least squares, stochastic tomography, multiplication and appearance transfer from front and side; the truth is known.
The paper shows 45 degrees.
"""

from common import BETWEEN, compare

compare("fig09", (0, 90), (0, 30, 45, 60, 90), BETWEEN)
