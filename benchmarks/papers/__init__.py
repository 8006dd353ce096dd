"""The figures of the documents that intarsia is built on, made again: ``python -m benchmarks.papers``."""
