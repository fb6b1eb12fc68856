"""A sweep as a picture file, drawn with matplotlib."""
