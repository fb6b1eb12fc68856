"""What keeps heavy requests from holding the others up."""
