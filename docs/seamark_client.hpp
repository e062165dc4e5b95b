// Orders runs of a Seamark service and follows them: a client for C++17 in one header.
//
// Needs libcurl (-lcurl) and nlohmann/json 3 (Debian: libcurl4-openssl-dev nlohmann-json3-dev).
// Call curl_global_init(CURL_GLOBAL_DEFAULT) before there are threads. A Client belongs to one
// thread at a time.
//
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <curl/curl.h>
#include <nlohmann/json.hpp>

namespace seamark {

using Json = nlohmann::json;
using Seconds = std::chrono::duration<double>;

// The service did not answer, or not as Seamark does.
class Unavailable : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// The service refused a request; what() says why.
class Refused : public std::runtime_error {
public:
    Refused(long refused_status, const std::string& why)
        : std::runtime_error(why), status(refused_status) {}
    const long status;  // of HTTP
};

// A run, as it was when it was asked for.
class Run {
public:
    explicit Run(Json found) : document(std::move(found)) {}

    std::int64_t id() const { return document.at("id").get<std::int64_t>(); }
    std::string state() const { return document.at("state").get<std::string>(); }
    bool is_over() const {
        return state() == "succeeded" || state() == "failed" || state() == "cancelled";
    }
    bool has_score() const {
        const auto result = document.find("result");
        return result != document.end() && result->is_object() && result->contains("score") &&
               result->at("score").is_number();
    }
    double score() const { return document.at("result").at("score").get<double>(); }

    Json document;  // all that the service says about it
};

class Client {
public:
    // Without a token you are a guest. `patience` limits the pauses of one request in total.
    explicit Client(std::string server, std::string token = "", Seconds patience = Seconds(60))
        : server_(std::move(server)), token_(std::move(token)), patience_(patience) {
        while (!server_.empty() && server_.back() == '/') server_.pop_back();
    }

    // Submit a run of a built-in controller: {"benchmark": ..., "controller": ..., "config": {...},
    // "seed": ...}, as POST /api/v1/runs takes it.
    Run submit(const Json& specification) const {
        Request request("POST", "/runs");
        request.body = specification.dump();
        return submitted(std::move(request));
    }

    // Submit a run of a program in a file.
    Run submit(const Json& specification, const std::string& program_path) const {
        Request request("POST", "/runs");
        request.body = specification.dump();
        request.program_path = program_path;
        return submitted(std::move(request));
    }

    // Return a run as it is now.
    Run run(std::int64_t id) const { return run_of(answer(show(id))); }

    // Ask for a run as often as the service wants to be asked, until it is over or time is up.
    Run wait(std::int64_t id, Seconds most = Seconds(24 * 3600)) const {
        const auto deadline = Clock::now() + most;
        for (;;) {
            const Answer found = answer(show(id));
            Run now = run_of(found);
            const Seconds left = deadline - Clock::now();
            if (now.is_over() || left <= Seconds(0)) return now;
            const Seconds pause = found.retry_after > Seconds(0) ? found.retry_after : Seconds(1);
            std::this_thread::sleep_for(std::min(pause, left));
        }
    }

    // Write a file of a run: "telemetry.csv", "metrics.json", "manifest.json".
    void download(std::int64_t id, const std::string& name, const std::string& path) const {
        Request request("GET", "/runs/" + std::to_string(id) + "/" + name);
        const File file(std::fopen(path.c_str(), "wb"), &std::fclose);
        if (!file) throw std::runtime_error(path + " cannot be written");
        request.into = file.get();
        answer(request);
        if (std::fflush(file.get()) != 0) throw std::runtime_error(path + " cannot be written");
    }

private:
    using Clock = std::chrono::steady_clock;
    using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
    using Easy = std::unique_ptr<CURL, void (*)(CURL*)>;
    using Headers = std::unique_ptr<curl_slist, void (*)(curl_slist*)>;
    using Form = std::unique_ptr<curl_mime, void (*)(curl_mime*)>;

    static constexpr std::size_t longest_answer = 64u << 20;  // [byte] kept in memory

    struct Request {
        Request(std::string with, std::string at) : method(std::move(with)), path(std::move(at)) {}
        std::string method, path, body, program_path, key;
        std::FILE* into = nullptr;  // of an answer that is not kept in memory
    };

    struct Answer {
        CURLcode code = CURLE_OK;
        long status = 0;
        Seconds retry_after{0};
        std::string body;
        CURL* easy = nullptr;
        std::FILE* into = nullptr;
    };

    static Request show(std::int64_t id) { return {"GET", "/runs/" + std::to_string(id)}; }

    // The service starts one run for a key, so that a request without an answer can be repeated.
    Run submitted(Request request) const {
        std::random_device device;
        for (int i = 0; i < 4; ++i) request.key += std::to_string(device()) + "-";
        return run_of(answer(request));
    }

    Run run_of(const Answer& found) const {
        Json document = Json::parse(found.body, nullptr, false);
        if (!document.is_object() || !document.contains("id") || !document.contains("state"))
            throw Unavailable(server_ + " is not a Seamark server. Check the address.");
        return Run(std::move(document));
    }

    // Return the answer to a request; repeats it while that is safe and may help.
    Answer answer(const Request& request) const {
        Seconds left = patience_, pause(0.5);
        for (;;) {
            Answer found = attempt(request);
            if (found.code == CURLE_OK && found.status >= 200 && found.status < 300) return found;
            const Seconds wait = std::max(found.retry_after, pause);
            if (!may_pass(request, found) || wait > left) fail(found);
            std::this_thread::sleep_for(wait);
            left -= wait;
            pause = std::min(pause * 2.0, Seconds(10));
        }
    }

    bool may_pass(const Request& request, const Answer& found) const {
        const bool harmless = request.method == "GET" || !token_.empty();
        switch (found.code) {
            case CURLE_OK:
                return found.status == 429 ||
                       (harmless && (found.status == 502 || found.status == 503 || found.status == 504));
            case CURLE_COULDNT_CONNECT:
            case CURLE_COULDNT_RESOLVE_HOST:
                return true;
            case CURLE_GOT_NOTHING:
            case CURLE_OPERATION_TIMEDOUT:
            case CURLE_PARTIAL_FILE:
            case CURLE_RECV_ERROR:
            case CURLE_SEND_ERROR:
                return harmless && request.into == nullptr;
            default:
                return false;
        }
    }

    [[noreturn]] void fail(const Answer& found) const {
        if (found.code != CURLE_OK)
            throw Unavailable(server_ + " did not answer: " + curl_easy_strerror(found.code));
        const Json problem = Json::parse(found.body, nullptr, false);
        if (!problem.is_object() || !problem.contains("title"))
            throw Unavailable(server_ + " answered with status " + std::to_string(found.status));
        throw Refused(found.status, problem.value("detail", problem.value("title", std::string())));
    }

    Answer attempt(const Request& request) const {
        Easy easy(curl_easy_init(), &curl_easy_cleanup);
        if (!easy) throw Unavailable("libcurl could not be set up");
        const Headers headers(headers_of(request), &curl_slist_free_all);
        const Form form(form_of(easy.get(), request), &curl_mime_free);
        const std::string url = server_ + "/api/v1" + request.path;
        Answer found;
        found.easy = easy.get();
        found.into = request.into;
        set(easy.get(), CURLOPT_URL, url.c_str());
        set(easy.get(), CURLOPT_HTTPHEADER, headers.get());
        set(easy.get(), CURLOPT_PROTOCOLS_STR, "http,https");
        set(easy.get(), CURLOPT_FOLLOWLOCATION, 0L);  // a token follows no redirect
        set(easy.get(), CURLOPT_NOSIGNAL, 1L);
        set(easy.get(), CURLOPT_CONNECTTIMEOUT, 10L);
        set(easy.get(), CURLOPT_LOW_SPEED_LIMIT, 1L);
        set(easy.get(), CURLOPT_LOW_SPEED_TIME, 60L);
        set(easy.get(), CURLOPT_WRITEFUNCTION, &Client::receive);
        set(easy.get(), CURLOPT_WRITEDATA, &found);
        if (form) {
            set(easy.get(), CURLOPT_MIMEPOST, form.get());
        } else if (request.method == "POST") {
            set(easy.get(), CURLOPT_POSTFIELDSIZE_LARGE, curl_off_t(request.body.size()));
            set(easy.get(), CURLOPT_POSTFIELDS, request.body.c_str());
        }
        found.code = curl_easy_perform(easy.get());
        curl_easy_getinfo(easy.get(), CURLINFO_RESPONSE_CODE, &found.status);
        curl_off_t retry_after = 0;
        curl_easy_getinfo(easy.get(), CURLINFO_RETRY_AFTER, &retry_after);
        found.retry_after = Seconds(double(retry_after));
        found.easy = nullptr;
        return found;
    }

    template <typename Value>
    static void set(CURL* easy, CURLoption option, Value value) {
        const CURLcode code = curl_easy_setopt(easy, option, value);
        if (code != CURLE_OK) throw Unavailable(curl_easy_strerror(code));
    }

    curl_slist* headers_of(const Request& request) const {
        curl_slist* list = curl_slist_append(nullptr, "Accept: application/json, */*");
        if (!token_.empty())
            list = curl_slist_append(list, ("Authorization: Bearer " + token_).c_str());
        if (request.method == "POST" && request.program_path.empty())
            list = curl_slist_append(list, "Content-Type: application/json");
        if (!request.key.empty() && !token_.empty())
            list = curl_slist_append(list, ("Idempotency-Key: " + request.key).c_str());
        return list;
    }

    static curl_mime* form_of(CURL* easy, const Request& request) {
        if (request.program_path.empty()) return nullptr;
        curl_mime* form = curl_mime_init(easy);
        curl_mimepart* run = curl_mime_addpart(form);
        curl_mime_name(run, "run");
        curl_mime_data(run, request.body.data(), request.body.size());
        curl_mimepart* program = curl_mime_addpart(form);
        curl_mime_name(program, "program");
        if (curl_mime_filedata(program, request.program_path.c_str()) != CURLE_OK) {
            curl_mime_free(form);
            throw std::runtime_error(request.program_path + " cannot be read");
        }
        return form;
    }

    // Keep a part of an answer; a failure's text is kept even if the answer goes into a file.
    static std::size_t receive(char* data, std::size_t, std::size_t size, void* to) {
        auto& found = *static_cast<Answer*>(to);
        long status = 0;
        curl_easy_getinfo(found.easy, CURLINFO_RESPONSE_CODE, &status);
        if (found.into != nullptr && status == 200)
            return std::fwrite(data, 1, size, found.into);
        if (found.body.size() + size > longest_answer) return 0;  // libcurl ends the transfer
        found.body.append(data, size);
        return size;
    }

    std::string server_, token_;
    Seconds patience_;
};

}  // namespace seamark
