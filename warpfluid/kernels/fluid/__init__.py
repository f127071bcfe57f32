"""What a fluid's fields go through in a step: carried, let in, burnt, spread, guided."""
