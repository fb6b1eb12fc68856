"""The commands about who may call the service."""
