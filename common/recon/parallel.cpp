#include <recon/parallel.h>

#include <recon/errors.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace recon
{

int resolve_threads(int threads)
{
    if (threads < 0)
        throw InvalidInput("The number of threads must be 0 (all cores) or more.");
    constexpr int most = 256; // every thread that is started costs time and memory, work or not
    return std::clamp(threads > 0 ? threads : int(std::thread::hardware_concurrency()), 1, most);
}

/// Its threads start when a loop first wants them.
class ThreadTeam::Helpers
{
public:
    ~Helpers()
    {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            ends_ = true;
        }
        wake_.notify_all();
        for (std::thread& thread : threads_)
            thread.join();
    }

    bool are_busy() const { return is_busy_; }

    /// Runs own() here and job() on up to `count` helpers beside it, until own() and all jobs that have begun are done.
    /// Neither may throw.
    void run(std::size_t count, const std::function<void()>& job, const std::function<void()>& own)
    {
        start(count);
        is_busy_ = true;
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            job_ = &job;
            wanted_ = count;
        }
        if (count < threads_.size())
            for (std::size_t i = 0; i < count; ++i)
                wake_.notify_one();
        else
            wake_.notify_all();
        own();
        std::unique_lock<std::mutex> lock(mutex_);
        wanted_ = 0; // there is nothing left for those that have not begun
        done_.wait(lock, [&] { return running_ == 0; });
        is_busy_ = false;
    }

private:
    void start(std::size_t count)
    {
        try
        {
            while (threads_.size() < count)
                threads_.emplace_back([this] { serve(); });
        }
        catch (const std::system_error&)
        {
            // The system gives no more threads: those that have started do the work.
        }
    }

    void serve()
    {
        std::unique_lock<std::mutex> lock(mutex_);
        while (true)
        {
            wake_.wait(lock, [&] { return ends_ || wanted_ > 0; });
            if (ends_)
                return;
            --wanted_;
            ++running_;
            const std::function<void()>& job = *job_;
            lock.unlock();
            job();
            lock.lock();
            if (--running_ == 0)
                done_.notify_one();
        }
    }

    std::mutex mutex_; // of what follows, down to ends_
    std::condition_variable wake_, done_;
    const std::function<void()>* job_ = nullptr;
    std::size_t wanted_ = 0, running_ = 0; // helpers
    bool ends_ = false;
    bool is_busy_ = false; // known to the owner's thread only
    std::vector<std::thread> threads_;
};

namespace
{
/// Those of this thread's team, if one lives.
thread_local ThreadTeam::Helpers* helpers_of_team = nullptr;
} // namespace

ThreadTeam::ThreadTeam()
{
    if (!helpers_of_team)
    {
        helpers_ = std::make_unique<Helpers>();
        helpers_of_team = helpers_.get();
    }
}

ThreadTeam::~ThreadTeam()
{
    if (helpers_)
        helpers_of_team = nullptr;
}

void parallel_chunks(std::size_t n, int threads, std::size_t grain, const Progress& progress,
                     const std::function<void(std::size_t begin, std::size_t end)>& body)
{
    const std::size_t chunks = (n + grain - 1) / grain;
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stop{false};
    std::mutex mutex;
    std::size_t failed_chunk = chunks;
    std::exception_ptr failure;

    const auto work = [&](bool is_caller)
    {
        while (!stop)
        {
            const std::size_t chunk = next++;
            if (chunk >= chunks)
                return;
            try
            {
                body(chunk * grain, std::min(n, (chunk + 1) * grain));
                if (is_caller)
                    progress.report(double(std::min(next.load(), chunks)) / double(chunks));
            }
            catch (...)
            {
                const std::lock_guard<std::mutex> lock(mutex);
                if (chunk < failed_chunk)
                {
                    failed_chunk = chunk;
                    failure = std::current_exception();
                }
                stop = true;
            }
        }
    };

    const std::size_t helpers = std::min<std::size_t>(std::max(threads, 1) - 1, chunks > 0 ? chunks - 1 : 0);
    if (helpers == 0)
        work(true);
    else
    {
        // A loop within a loop has helpers of its own.
        ThreadTeam::Helpers own_helpers, *const team = helpers_of_team;
        (team && !team->are_busy() ? *team : own_helpers)
            .run(
                helpers, [&] { work(false); }, [&] { work(true); });
    }
    if (failure)
        std::rethrow_exception(failure);
    if (chunks > 0)
        progress.report(1); // also where the helpers took every chunk: whoever wants to stop is asked
}

void parallel_shares(std::size_t n, int threads, const std::function<void(const Share& share)>& body)
{
    constexpr int most = 8;
    const std::size_t shares = std::size_t(std::clamp(threads, 1, most));
    parallel_chunks(n, threads, std::max<std::size_t>(1, (n + shares - 1) / shares), {},
                    [&](std::size_t begin, std::size_t end) {
                        body({begin, end});
                    });
}

void parallel_invoke(int threads, const std::function<void()>& first, const std::function<void()>& second)
{
    if (threads < 2)
    {
        first();
        second();
        return;
    }
    std::exception_ptr failure;
    std::thread beside;
    try
    {
        beside = std::thread(
            [&]
            {
                try
                {
                    second();
                }
                catch (...)
                {
                    failure = std::current_exception();
                }
            });
    }
    catch (const std::system_error&)
    {
        first();
        second();
        return;
    }
    try
    {
        first();
    }
    catch (...)
    {
        beside.join();
        throw;
    }
    beside.join();
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace recon
