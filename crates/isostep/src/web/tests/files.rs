//! What is served, and to whom.

use super::*;

#[test]
fn the_page_is_served_with_its_policy_and_nothing_else_is() {
    let (host, _) = served("files", None);
    let own = format!("Host: {host}\r\n");
    let index = get(&host, "/", &own);
    assert!(index.starts_with("HTTP/1.1 200") && index.ends_with(INDEX), "{index}");
    for header in [
        "content-type: text/html; charset=utf-8\r\n",
        "content-security-policy: default-src 'none'; frame-ancestors 'none'\r\n",
        "x-content-type-options: nosniff\r\n",
        "cross-origin-opener-policy: same-origin\r\n",
        "cache-control: no-cache\r\n",
    ] {
        assert!(index.contains(header), "no {header} in {index}");
    }
    assert!(get(&host, "/programs/a.nc", &own).ends_with("\r\n\r\nG0 X1"));
    assert!(get(&host, "/board.json", &own).ends_with("{\"has_board\":false}"));
    for path in
        ["/../Cargo.toml", "/%2e%2e/Cargo.toml", "/programs/../../../etc/passwd", "//etc/passwd", "/none", "/programs"]
    {
        let answer = get(&host, path, &own);
        assert!(answer.starts_with("HTTP/1.1 404"), "{path}: {answer}");
        assert!(answer.contains("content-security-policy: "), "{path}: {answer}");
    }
}

#[test]
fn what_is_compressed_is_sent_to_those_who_read_it() {
    let (host, _) = served("gzip", None);
    let gzip = get(&host, "/main.js", &format!("Host: {host}\r\nAccept-Encoding: deflate, gzip\r\n"));
    assert!(gzip.contains("content-encoding: gzip\r\n") && gzip.contains("text/javascript"), "{gzip}");
    assert!(gzip.ends_with("compressed"), "{gzip}");
    let brotli = get(&host, "/main.js", &format!("Host: {host}\r\nAccept-Encoding: gzip, br;q=1\r\n"));
    assert!(brotli.contains("content-encoding: br\r\n") && brotli.ends_with("smaller"), "{brotli}");
    let plain = get(&host, "/main.js", &format!("Host: {host}\r\n"));
    assert!(plain.ends_with("\r\n\r\n1") && !plain.contains("content-encoding"), "{plain}");
}

#[test]
fn a_server_goes_by_its_own_name_alone() {
    let (host, _) = served("host", None);
    let port = host.rsplit(':').next().unwrap();
    assert!(get(&host, "/", &format!("Host: LocalHost:{port}\r\n")).starts_with("HTTP/1.1 200"));
    for (headers, name) in [
        (format!("Host: evil.example:{port}\r\n"), format!("evil.example:{port}")),
        ("Host: 127.0.0.1\r\n".to_owned(), "127.0.0.1".to_owned()),
    ] {
        let answer = get(&host, "/", &headers);
        assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
        assert!(answer.contains(&format!("`{name}` is not how this server is called: use http://{host}")), "{answer}");
    }
}

#[test]
fn a_board_is_for_our_page_with_its_token() {
    let (host, token) = served("gate", Some(Path::new("/dev/none")));
    assert_eq!(token.len(), 32);
    let own = format!("http://{host}");
    let refused = |origin: &str, query: &str| Client::from(&host, origin, query).err().unwrap();
    for origin in ["http://evil.example", "null", "", &format!("https://{host}"), "http://127.0.0.1"] {
        let words = refused(origin, &format!("?token={token}"));
        assert!(words.starts_with("403") && words.contains("may not operate the board"), "{origin}: {words}");
    }
    let (wrong, longer) = (format!("?token={}", "0".repeat(32)), format!("?token={token}0"));
    for query in ["", "?token=", &wrong, &longer, &format!("?token={}", &token[1..])] {
        let words = refused(&own, query);
        assert!(words.starts_with("403") && words.contains("the token is missing or old"), "{query}: {words}");
    }
    let mut client = Client::open(&host, &token);
    assert!(client.hear(">>").starts_with("<<{\"is\":\"ended\",\"why\":\"/dev/none: there is no such port"));
    assert_ne!(served("other", Some(Path::new("/dev/none"))).1, token);
}

#[test]
fn what_cannot_be_served_is_reported_with_its_remedy() {
    let taken = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let refused = |at: SocketAddr| Server::bind(page("taken"), None, at).err().unwrap().to_string();
    let words = refused(taken.local_addr().unwrap());
    assert!(words.starts_with("another program has port ") && words.contains("--http-port"), "{words}");
    let words = refused("192.0.2.1:8000".parse().unwrap());
    assert!(words.starts_with("192.0.2.1 is no address of this computer"), "{words}");
    if option_env!("ISOSTEP_PAGE").is_none() {
        let none = Page::own().err().unwrap().to_string();
        assert!(none.contains("built without the page") && none.contains("cargo xtask web --install"), "{none}");
    }
    let none = Page::read(Path::new("/dev")).err().unwrap().to_string();
    assert!(none.contains("/dev has no page in it") && none.contains("cargo xtask web"), "{none}");
}
