"""The plane-stress laws of the shell."""
