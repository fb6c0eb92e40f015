"""Many crawlers at once: in lanes, each to the bit as it moves alone."""
