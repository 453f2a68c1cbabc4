// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/phd_filter_impl.h"

namespace kestrel {

template ExpectedObservation<7, 3> expectPosition<7, 3>(const Eigen::Matrix<double, 7, 1>&);
template class PhdFilter<7, 3>;

}  // namespace kestrel
