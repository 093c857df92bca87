"""Shared parts of the package's offline tools (bags, geometry, evaluation, plots)."""
