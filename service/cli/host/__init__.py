"""The commands of whoever runs the service: on this machine, beside or around the service."""
