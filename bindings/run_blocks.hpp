// Blocks of worlds over threads.
//
// Included by the kernels of each instruction set, so that all is in their unnamed namespaces.
#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace multilift::bindings {

namespace {

namespace nb = nanobind;

/// Hands blocks of lanes to threads; meanwhile the calling thread reports progress and listens for
/// Ctrl-C about ten times a second.
template <class RunBlock>
void run_blocks(std::size_t worlds, unsigned threads, const nb::object& progress,
                const RunBlock& run_block) {
  std::atomic<std::size_t> next{0}, done{0};
  std::atomic<bool> cancelled{false};
  std::atomic<unsigned> running{threads};
  std::mutex mutex;
  std::condition_variable finished;
  const auto work = [&] {
    for (;;) {
      const std::size_t first = next.fetch_add(MULTILIFT_LANES);
      if (first >= worlds || cancelled) break;
      run_block(first);
      done += std::min<std::size_t>(MULTILIFT_LANES, worlds - first);
    }
    const std::lock_guard lock(mutex);
    if (--running == 0) finished.notify_all();
  };
  std::vector<std::thread> pool;
  const auto stop = [&] {
    cancelled = true;
    nb::gil_scoped_release unlock;
    for (std::thread& thread : pool) thread.join();
    pool.clear();
  };
  for (unsigned k = 0; k < threads; ++k) pool.emplace_back(work);
  try {
    for (bool over = false; !over;) {
      {
        nb::gil_scoped_release unlock;
        std::unique_lock lock(mutex);
        over =
            finished.wait_for(lock, std::chrono::milliseconds(100), [&] { return running == 0; });
      }
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      if (!progress.is_none()) progress(done.load());
    }
  } catch (...) {
    stop();
    throw;
  }
  stop();
}

}  // namespace

}  // namespace multilift::bindings
