"""What `primfit batch` costs on one machine and on a cluster: runs that are watched, and a simulation of
larger ones. It needs the environment that `make test-ray` makes."""
