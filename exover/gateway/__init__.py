"""Where the outside world meets a checker: streams of events in, answers out."""
