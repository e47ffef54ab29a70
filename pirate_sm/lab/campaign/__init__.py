"""Campaigns: missions run many times on Dask workers, judged by the simulator's truth, counted."""
