"""Files: one format a file; readers and writers turn the formats' arrays into the package's and back."""
