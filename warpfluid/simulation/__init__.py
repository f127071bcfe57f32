"""Section 4: a fluid simulator that follows the volumes and obeys the artist, in Maya's place."""
