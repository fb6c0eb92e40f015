"""What every other folder stands on: validation, files, figures, terminals, extras. Knows nothing of crawlers."""
