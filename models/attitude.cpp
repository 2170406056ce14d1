// What of attitudes needs a decomposition: in no hot loop, and the header is read by every file.
#include "models/attitude.hpp"

#include <Eigen/SVD>

namespace polhode {

Mat3 nearest_rotation(const Mat3& m) {
  if (!m.allFinite()) return m;
  const Eigen::JacobiSVD<Mat3> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
  return svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

}  // namespace polhode
