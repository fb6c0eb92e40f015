"""Where steps meet events: slips, stops and turns, and the energies in between."""
