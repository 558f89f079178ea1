"""Other planners' words for this one: `srmp.compat.mplib`."""
