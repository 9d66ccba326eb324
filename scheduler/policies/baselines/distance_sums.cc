#include "scheduler/policies/baselines/distance_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace muster::scheduler {
namespace {

/// Targets nearer than so many times the distance from a block's centre to its farthest cell are
/// summed one by one.
constexpr double kNear = 2;

/// Sum of |v + h| over many v as a polynomial of h, up to third degree. With u = v / |v|:
///     |v + h| = |v| + u.h + (u x h)^2 / (2 |v|) - (u.h) (u x h)^2 / (2 |v|^2) + ...
class Taylor {
 public:
  static constexpr std::size_t kLanes = 2;  ///< vectors that are added side by side

  /// `reach`: |h| is at most that, and every |v| at least twice that.
  void Add(const std::array<double, kLanes>& vx, const std::array<double, kLanes>& vy,
           double reach) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double distance = std::sqrt(vx[i] * vx[i] + vy[i] * vy[i]);
      const double inverse = 1 / distance;
      const double ux = vx[i] * inverse, uy = vy[i] * inverse;
      const double half = inverse / 2, cubic = inverse * half;
      const double uxx = ux * ux, uyy = uy * uy;
      one_[i] += distance;
      x_[i] += ux;
      y_[i] += uy;
      xx_[i] += half * uyy;
      xy_[i] -= inverse * (ux * uy);
      yy_[i] += half * uxx;
      xxx_[i] -= cubic * ux * uyy;
      xxy_[i] -= cubic * uy * (uyy - 2 * uxx);
      xyy_[i] -= cubic * ux * (uxx - 2 * uyy);
      yyy_[i] -= cubic * uy * uxx;
      // The n-th term of |v + h| is |v| r^n times a number of at most 2 / (2 n - 1), r = |h| / |v|.
      // 1 / (1 - r) is at most 1 + 2 r.
      left_out_[i] += 2.0 / 7 * inverse * inverse * inverse * (1 + 2 * reach * inverse);
    }
  }
  double At(double hx, double hy) const {
    return Of(one_) + Of(x_) * hx + Of(y_) * hy + Of(xx_) * hx * hx + Of(xy_) * hx * hy +
           Of(yy_) * hy * hy + hx * hx * (Of(xxx_) * hx + Of(xxy_) * hy) +
           hy * hy * (Of(xyy_) * hx + Of(yyy_) * hy);
  }
  /// Per fourth power of |h|.
  double left_out() const { return Of(left_out_); }

 private:
  using Sum = std::array<double, kLanes>;
  static double Of(const Sum& sum) { return sum[0] + sum[1]; }

  Sum one_{}, x_{}, y_{}, xx_{}, xy_{}, yy_{}, xxx_{}, xxy_{}, xyy_{}, yyy_{}, left_out_{};
};

}  // namespace

DistanceSums::Block DistanceSums::MakeBlock(int column, int row) const {
  const Point middle{(column + 0.5) * kSide * cell_m_, (row + 0.5) * kSide * cell_m_};
  const double half_side = kMiddle * cell_m_;
  const double reach = half_side * std::sqrt(2.0);
  const double near = kNear * reach;
  Taylor far;
  std::vector<Point> close;
  std::array<double, Taylor::kLanes> far_x, far_y;
  std::size_t lane = 0;
  Point last_far;
  for (const Point target : targets_) {
    const double vx = middle.x_m - target.x_m, vy = middle.y_m - target.y_m;
    if (vx * vx + vy * vy < near * near) {
      close.push_back(target);
      continue;
    }
    far_x[lane] = vx;
    far_y[lane] = vy;
    last_far = target;
    if (++lane < Taylor::kLanes) continue;
    far.Add(far_x, far_y, reach);
    lane = 0;
  }
  if (lane > 0) close.push_back(last_far);
  Block block;
  block.sum.resize(std::size_t{kSide} * kSide);
  double most = 0;
  for (std::size_t i = 0; i < kSide; ++i) {
    const double hy = static_cast<double>(i) * cell_m_ - half_side, y = middle.y_m + hy;
    std::array<double, kSide> sum;
    for (std::size_t k = 0; k < kSide; ++k) {
      sum[k] = far.At(static_cast<double>(k) * cell_m_ - half_side, hy);
    }
    for (const Point target : close) {
      const double dy = y - target.y_m, dx0 = middle.x_m - half_side - target.x_m;
      for (std::size_t k = 0; k < kSide; ++k) {
        const double dx = dx0 + static_cast<double>(k) * cell_m_;
        sum[k] += std::sqrt(dx * dx + dy * dy);
      }
    }
    for (std::size_t k = 0; k < kSide; ++k) {
      block.sum[i * kSide + k] = sum[k];
      most = std::max(most, sum[k]);
    }
  }
  // Rounding: of this sum and of the one that it is compared with.
  block.rounding = 16 * std::numeric_limits<double>::epsilon() * most *
                   static_cast<double>(targets_.size() + 16);
  block.left_out = far.left_out();
  return block;
}

DistanceSums::Bounds DistanceSums::BoundsOf(int column, int row) {
  const std::int64_t key = std::int64_t{row / kSide} << 32 | (column / kSide);
  if (key != last_key_) {
    const auto known = blocks_.find(key);
    last_ = known != blocks_.end()
                ? &known->second
                : &blocks_.emplace(key, MakeBlock(column / kSide, row / kSide)).first->second;
    last_key_ = key;
  }
  const double sum = last_->sum[static_cast<std::size_t>(row % kSide) * kSide +
                                static_cast<std::size_t>(column % kSide)];
  const double hx = (column % kSide - kMiddle) * cell_m_, hy = (row % kSide - kMiddle) * cell_m_;
  const double h2 = hx * hx + hy * hy;
  const double error = last_->left_out * h2 * h2 + last_->rounding;
  return {sum - error, sum + error};
}

}  // namespace muster::scheduler
