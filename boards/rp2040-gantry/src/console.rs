//! interim
use embedded_io_async::{Read, Write};

/// interim
pub async fn serve<R: Read, W: Write>(rx: &mut R, tx: &mut W) -> Option<()> {
    tx.write_all(b"\r\nGrbl 1.1h ['$' for help]\r\n").await.ok()?;
    let mut buffer = [0; 64];
    loop {
        let n = rx.read(&mut buffer).await.ok()?;
        tx.write_all(&buffer[..n]).await.ok()?;
    }
}
