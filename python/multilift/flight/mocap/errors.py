"""What goes wrong between us and a motion capture system."""

from multilift.errors import MultiliftError


class CaptureError(MultiliftError):
    """A motion capture system that is not there, went away, or does not have what is asked."""
