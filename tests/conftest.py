"""What all tests stand on."""

import signal


def pytest_configure():
    """Lets what the tests start be interrupted: from a shell's background, Ctrl-C is ignored."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
