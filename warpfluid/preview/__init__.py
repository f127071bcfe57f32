"""Looking at volumes: a page for the browser, a window, and the still picture where neither will do."""
