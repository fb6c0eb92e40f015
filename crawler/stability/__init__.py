"""How small changes of a motion grow: tangents through steps and events, and the rates that they show."""
