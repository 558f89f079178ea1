"""Interfaces of other planners, implemented with this one: `srmp.compat.mplib`."""
