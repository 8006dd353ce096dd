"""Campaigns of mutated files, kills and damaged caches: `make fuzz N=1000`. No part of `make test`."""
