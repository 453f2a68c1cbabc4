// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/phd_filter_impl.h"

namespace kestrel {

template ExpectedObservation<4, 2> expectPosition<4, 2>(const Eigen::Matrix<double, 4, 1>&);
template class PhdFilter<4, 2>;

}  // namespace kestrel
