"""The service: queue, store, REST, command line."""
