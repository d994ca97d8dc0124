"""Runs seen in three dimensions: scenes, an offline page, recordings and animations."""
