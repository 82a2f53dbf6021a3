"""Runs of many segments: by reference from anywhere, in tasks, into a folder of Parquet files."""
