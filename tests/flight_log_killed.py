"""Run by test_flight_log: logs, says what it has logged, and waits to be killed."""

import sys
import time
from pathlib import Path

from multilift.flight.log import Log

log = Log(Path(sys.argv[1]), time.monotonic())
print(log.writer, flush=True)
k = 0
while True:
    log.write("count", time.monotonic(), {"k": k})
    print(k, flush=True)
    k += 1
    time.sleep(0.002)
