"""From clips to views: opened, paired by frame, checked and prepared, with an estimate of what they will cost."""
