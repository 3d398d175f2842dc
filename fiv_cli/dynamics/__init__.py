"""The contact state machine and the event-exact integrator, once for all models."""
