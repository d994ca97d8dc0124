// A double that counts what is done with it: how many operations an equation takes.
//
// Run over it, the very code of a rollout says how much arithmetic a step is. Counts belong to the
// thread; constants and copies are free, as are conversions from literals.
#pragma once

#include "multilift/scalar/real.hpp"

namespace multilift {

/// Arithmetic on numbers, by kind.
struct Operations {
  long long add{0};       // sums and differences
  long long multiply{0};  // products
  long long divide{0};    // quotients
  long long root{0};      // square roots
  long long other{0};     // comparisons, selections, magnitudes, signs: no flops

  long long flops() const { return add + multiply + divide + root; }

  friend Operations operator-(const Operations& a, const Operations& b) {
    return {a.add - b.add, a.multiply - b.multiply, a.divide - b.divide, a.root - b.root,
            a.other - b.other};
  }
};

class Counting {
 public:
  Counting() = default;
  Counting(double x) : x_(x) {}  // NOLINT(google-explicit-constructor): a literal is a Real

  /// Of this thread, since it began.
  static Operations& operations() {
    thread_local Operations all;
    return all;
  }

  friend Counting operator+(const Counting& a, const Counting& b) {
    ++operations().add;
    return a.x_ + b.x_;
  }
  friend Counting operator-(const Counting& a, const Counting& b) {
    ++operations().add;
    return a.x_ - b.x_;
  }
  friend Counting operator*(const Counting& a, const Counting& b) {
    ++operations().multiply;
    return a.x_ * b.x_;
  }
  friend Counting operator/(const Counting& a, const Counting& b) {
    ++operations().divide;
    return a.x_ / b.x_;
  }
  friend Counting operator-(const Counting& a) { return other(-a.x_); }
  Counting& operator+=(const Counting& b) { return *this = *this + b; }
  Counting& operator-=(const Counting& b) { return *this = *this - b; }
  Counting& operator*=(const Counting& b) { return *this = *this * b; }

  friend bool operator<(const Counting& a, const Counting& b) { return other(a.x_ < b.x_); }
  friend bool operator<=(const Counting& a, const Counting& b) { return other(a.x_ <= b.x_); }
  friend bool operator>(const Counting& a, const Counting& b) { return other(a.x_ > b.x_); }
  friend bool operator>=(const Counting& a, const Counting& b) { return other(a.x_ >= b.x_); }

  friend Counting sqrt(const Counting& a) {
    ++operations().root;
    return std::sqrt(a.x_);
  }
  friend Counting abs(const Counting& a) { return other(std::fabs(a.x_)); }
  friend Counting select(bool mask, const Counting& a, const Counting& b) {
    return other(mask ? a.x_ : b.x_);
  }
  // Functions outside the hot loop: their own arithmetic is not seen.
  friend Counting exp(const Counting& a) { return other(std::exp(a.x_)); }
  friend Counting atan(const Counting& a) { return other(std::atan(a.x_)); }
  friend Counting atan2(const Counting& y, const Counting& x) {
    return other(std::atan2(y.x_, x.x_));
  }
  friend double value(const Counting& a) { return a.x_; }

 private:
  template <class T>
  static T other(T result) {
    ++operations().other;
    return result;
  }

  double x_{0.0};
};

}  // namespace multilift
