"""What all vehicles do together, and when it must end: a state machine without input or output."""

from multilift.flight.supervisor.machine import Order, Orders, Supervisor
from multilift.flight.supervisor.seen import Seen, VehicleSeen, Word
from multilift.flight.supervisor.states import State

__all__ = ["Order", "Orders", "Seen", "State", "Supervisor", "VehicleSeen", "Word"]
