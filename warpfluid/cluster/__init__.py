"""Frames side by side: in this process, in processes of this machine, or on a Dask cluster, by one code path."""
