"""The API: HTTP, its safety, its forms and its pages."""
