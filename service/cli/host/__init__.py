"""The commands of the operator of a service, which run on its machine."""
