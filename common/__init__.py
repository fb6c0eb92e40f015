"""What every other folder stands on: validation, files, terminals, extras. Knows nothing of crawlers."""
