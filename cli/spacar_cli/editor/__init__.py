"""`spacar edit`: the page with editor and picture, its server, and the processes that check, draw and run."""
