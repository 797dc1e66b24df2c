"""Benchmarks: `python -m benchmarks`; needs `pip install ".[benchmark]"`."""
