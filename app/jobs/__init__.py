"""Work that outlives a request: jobs in a database, their bodies and results as files beside it."""
