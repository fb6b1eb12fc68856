"""What learners share that learn only from the steps their present policy took."""
