// Spherical and cylindrical Bessel functions of many orders, without underflow or overflow.
//
//   BesselValue  spherical_j  spherical_y  cylindrical_j  cylindrical_y
#pragma once

#include <vector>

namespace ensonify {

// The function is value 2^exponent, and x times its derivative is slope 2^exponent.
struct BesselValue {
  double value = 0, slope = 0;
  int exponent = 0;
};

// j_n(x) and y_n(x) for n = 0 ... orders - 1 and x > 0; relative error about 1e-13, except next to
// the zeros. j by downward recurrence from an order where it has vanished (Miller's method), y by
// upward recurrence; the slopes are x f_n' = n f_n - x f_(n+1)  (Abramowitz and Stegun, 10.1.22).
std::vector<BesselValue> spherical_j(int orders, double x);
std::vector<BesselValue> spherical_y(int orders, double x);

// The same for J_n(x) and Y_n(x)  (Abramowitz and Stegun, 9.1.27).
std::vector<BesselValue> cylindrical_j(int orders, double x);
std::vector<BesselValue> cylindrical_y(int orders, double x);

}  // namespace ensonify
