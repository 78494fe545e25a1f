// Joint values that bring the last frame of a chain of joints to poses, by damped least squares.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace {

struct Chain {
    const double *terms;  // (n, 3, 4, 3): what is constant, goes with cos(q) or q, and with sin(q)
    const double *axes;   // (n, 3) in the frame behind each joint
    const uint8_t *turns;
    const double *lower, *upper;
    int64_t size;
};

struct Frame {
    double r[9], p[3];
};

// Where the last frame is, and each joint's axis and place in the base.
Frame forward(const Chain &chain, const double *q, std::vector<double> &axes, std::vector<double> &places) {
    Frame at = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    for (int64_t k = 0; k < chain.size; ++k) {
        const double one = chain.turns[k] ? std::cos(q[k]) : q[k], two = chain.turns[k] ? std::sin(q[k]) : 0.0;
        double local[12];
        for (int i = 0; i < 12; ++i) {
            const double *t = chain.terms + 36 * k + 3 * i;
            local[i] = t[0] + one * t[1] + two * t[2];
        }
        Frame next;
        for (int i = 0; i < 3; ++i) {
            const double *r = at.r + 3 * i;
            for (int j = 0; j < 3; ++j) next.r[3 * i + j] = r[0] * local[j] + r[1] * local[4 + j] + r[2] * local[8 + j];
            next.p[i] = at.p[i] + r[0] * local[3] + r[1] * local[7] + r[2] * local[11];
        }
        at = next;
        const double *axis = chain.axes + 3 * k;
        for (int i = 0; i < 3; ++i) {
            axes[3 * k + i] = at.r[3 * i] * axis[0] + at.r[3 * i + 1] * axis[1] + at.r[3 * i + 2] * axis[2];
            places[3 * k + i] = at.p[i];
        }
    }
    return at;
}

// Axis times angle of a rotation [rad].
void rotation_vector(const double *r, double *found) {
    const double twice[3] = {r[7] - r[5], r[2] - r[6], r[3] - r[1]};
    const double sine = std::sqrt(twice[0] * twice[0] + twice[1] * twice[1] + twice[2] * twice[2]) / 2.0;
    const double cosine = (r[0] + r[4] + r[8] - 1.0) / 2.0, angle = std::atan2(sine, cosine);
    for (int i = 0; i < 3; ++i) found[i] = twice[i] * angle / std::max(2.0 * sine, 1e-12);
    if (sine >= 1e-6 || cosine >= 0.0) return;
    int column = 0;  // near pi the antisymmetric part vanishes; the axis is then the largest column of R + I
    for (int i = 1; i < 3; ++i)
        if (r[4 * i] > r[4 * column]) column = i;
    double length = 0.0;
    for (int i = 0; i < 3; ++i) found[i] = r[3 * i + column] + (i == column), length += found[i] * found[i];
    for (int i = 0; i < 3; ++i) found[i] *= angle / std::sqrt(length);
}

// J^T (J J^T + damping)^-1 error of a Jacobian with columns (n, 6).
void damped(const std::vector<double> &columns, int64_t n, const double *error, double damping, double *delta) {
    double a[6][6], x[6];
    for (int i = 0; i < 6; ++i) {
        for (int j = 0; j <= i; ++j) {
            double sum = i == j ? damping : 0.0;
            for (int64_t k = 0; k < n; ++k) sum += columns[6 * k + i] * columns[6 * k + j];
            for (int m = 0; m < j; ++m) sum -= a[i][m] * a[j][m];
            a[i][j] = i == j ? std::sqrt(sum) : sum / a[j][j];
        }
    }
    for (int i = 0; i < 6; ++i) {
        x[i] = error[i];
        for (int m = 0; m < i; ++m) x[i] -= a[i][m] * x[m];
        x[i] /= a[i][i];
    }
    for (int i = 5; i >= 0; --i) {
        for (int m = i + 1; m < 6; ++m) x[i] -= a[m][i] * x[m];
        x[i] /= a[i][i];
    }
    for (int64_t k = 0; k < n; ++k) {
        delta[k] = 0.0;
        for (int i = 0; i < 6; ++i) delta[k] += columns[6 * k + i] * x[i];
    }
}

double length(const double *v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

extern "C" {

// From `count` starts (count, n) for each of some targets (4, 4): those that come within [m] and [rad] of
// theirs in so many steps of at most `largest`, or within the second two at their end; how many, with the
// target of each. What is brought there is a point of the last frame.
int64_t chain_solve(const double *terms, const double *axes, const uint8_t *turns, const double *lower,
                    const double *upper, int64_t n, const double *targets, int64_t wanted, const double *starts,
                    int64_t count, const double *point, const double *within, int64_t steps, double largest,
                    double *solutions, int64_t *owners) {
    const Chain chain = {terms, axes, turns, lower, upper, n};
    std::vector<double> q(n), delta(n), turned(3 * n), places(3 * n), columns(6 * n);
    int64_t found = 0;
    for (int64_t start = 0; start < wanted * count; ++start) {
        const double *target = targets + 16 * (start / count);
        std::copy_n(starts + n * start, n, q.data());
        for (int64_t step = 0; step <= steps; ++step) {
            const Frame at = forward(chain, q.data(), turned, places);
            double error[6], relative[9], place[3];
            for (int i = 0; i < 3; ++i) {
                const double *r = at.r + 3 * i, *t = target + 4 * i;
                place[i] = at.p[i] + r[0] * point[0] + r[1] * point[1] + r[2] * point[2];
                error[i] = t[3] + t[0] * point[0] + t[1] * point[1] + t[2] * point[2] - place[i];
                for (int j = 0; j < 3; ++j) {
                    const double *o = at.r + 3 * j;
                    relative[3 * i + j] = t[0] * o[0] + t[1] * o[1] + t[2] * o[2];
                }
            }
            rotation_vector(relative, error + 3);
            const double *limits = within + (step == steps ? 2 : 0);
            if (length(error) < limits[0] && length(error + 3) < limits[1]) {
                std::copy_n(q.data(), n, solutions + n * found);
                owners[found++] = start / count;
                break;
            }
            if (step == steps) break;
            double square = 0.0, size = 0.0;
            for (const double e : error) square += e * e;
            for (int64_t k = 0; k < n; ++k) {
                const double *a = turned.data() + 3 * k, *p = places.data() + 3 * k;
                double *column = columns.data() + 6 * k;
                for (int i = 0; i < 3; ++i) {
                    const int j = (i + 1) % 3, m = (i + 2) % 3;
                    column[i] = turns[k] ? a[j] * (place[m] - p[m]) - a[m] * (place[j] - p[j]) : a[i];
                    column[3 + i] = turns[k] ? a[i] : 0.0;
                }
            }
            const double damping = 0.05 * square + 1e-7;  // fades with the error (Sugihara 2011)
            damped(columns, n, error, damping, delta.data());
            bool blocked = false;
            for (int64_t k = 0; k < n; ++k) {
                if (!((q[k] <= lower[k] && delta[k] < 0) || (q[k] >= upper[k] && delta[k] > 0))) continue;
                blocked = true;
                std::fill_n(columns.data() + 6 * k, 6, 0.0);
            }
            if (blocked) damped(columns, n, error, damping, delta.data());
            for (const double d : delta) size = std::max(size, std::abs(d));
            const double share = std::min(1.0, largest / std::max(size, 1e-12));
            for (int64_t k = 0; k < n; ++k) q[k] = std::min(std::max(q[k] + share * delta[k], lower[k]), upper[k]);
        }
    }
    return found;
}
}
