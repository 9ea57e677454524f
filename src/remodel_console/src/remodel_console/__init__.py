"""The operator console: pages for the browser, and the commands of /flexbe/uicommand."""
