"""Work of the pressure over ensembles of inputs and of starts: its balance, its spread, and Jarzynski's average."""
