// Pinocchio called the way its examples do, in a loop over samples: `pinocchio SAMPLES ROUNDS` prints the best time per sample of every round in microseconds, one line
// per kernel: name, then the rounds. Seven revolute joints with bodies; times do not depend on their numbers.
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

#include <chrono>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

namespace pin = pinocchio;

static void timed(const char* name, int samples, int rounds, const std::function<void()>& work) {
    std::cout << name;
    for (int round = 0; round < rounds; ++round) {
        double best = 1e300;
        for (int repeat = 0; repeat < 5; ++repeat) {
            const auto begun = std::chrono::steady_clock::now();
            work();
            best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
        }
        std::cout << ' ' << 1e6 * best / samples;
    }
    std::cout << '\n';
}

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    pin::Model model;
    pin::JointIndex last = 0;
    for (int j = 0; j < 7; ++j) {
        const auto turn = Eigen::AngleAxisd(j % 2 ? 1.57 : -1.57, Eigen::Vector3d::UnitX()).toRotationMatrix();
        last = model.addJoint(last, pin::JointModelRZ(), pin::SE3(turn, Eigen::Vector3d(0, 0, 0.2)), "joint" + std::to_string(j));
        model.appendBodyToJoint(last, pin::Inertia::Random(), pin::SE3::Identity());
    }
    pin::Data data(model);
    const int samples = std::atoi(argv[1]), rounds = std::atoi(argv[2]), n = model.nv, width = 10 * n;
    std::vector<Eigen::VectorXd> q(samples), v(samples), a(samples);
    for (int s = 0; s < samples; ++s) {
        const auto phase = Eigen::ArrayXd::LinSpaced(n, 0, n - 1) + 0.01 * s;
        q[s] = phase.sin();
        v[s] = phase.cos();
        a[s] = -phase.sin();
    }
    double sink = 0;
    timed("inverse_dynamics", samples, rounds, [&] {
        for (int s = 0; s < samples; ++s) sink += pin::rnea(model, data, q[s], v[s], a[s])[0];
    });
    timed("regressor", samples, rounds, [&] {
        for (int s = 0; s < samples; ++s) sink += pin::computeJointTorqueRegressor(model, data, q[s], v[s], a[s])(0, 0);
    });
    // What a criterion needs at least: all rows, and their Gram matrix.
    Eigen::MatrixXd stacked(samples * n, width), gram(width, width);
    timed("regressor_and_gram", samples, rounds, [&] {
        for (int s = 0; s < samples; ++s)
            stacked.middleRows(s * n, n) = pin::computeJointTorqueRegressor(model, data, q[s], v[s], a[s]);
        gram.setZero();
        gram.selfadjointView<Eigen::Lower>().rankUpdate(stacked.transpose());
        sink += gram(0, 0);
    });
    return sink == 0.123 ? 1 : 0;
}
