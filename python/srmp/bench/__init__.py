"""Benchmarks on public problem sets."""
