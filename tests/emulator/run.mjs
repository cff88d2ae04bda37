#!/usr/bin/env node
try {
  const { main } = await import('./src/main.mjs');
  process.exitCode = main(process.argv.slice(2));
} catch (error) {
  if (error.code !== 'ERR_MODULE_NOT_FOUND') throw error;
  console.error(`error: ${error.message}\nInstall what the emulator needs: npm ci --prefix tests/emulator`);
  process.exitCode = 2;
}
