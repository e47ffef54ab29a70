"""Recordings as tables: CSV files, and Parquet files with types and units."""
