"""Studies of the paper: their study files, and what they say."""
