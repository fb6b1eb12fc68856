"""The dashboard: templates, ES modules and styles, served by the service as data."""
