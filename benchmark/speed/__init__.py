"""How long a fit takes: step by step beside what the machine could do, and beside what others make."""
