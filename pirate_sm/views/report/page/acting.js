// Acts on the run: for those whose address has the token that the run printed.

const startActing = () => {
  const bar = byId('acting'), answered = byId('answered'), token = location.hash.slice(1);
  const buttons = [...bar.querySelectorAll('button')];

  const press = async (button) => {
    const name = button.textContent || button.getAttribute('aria-label'), stops = button.dataset.press === 'stop';
    answered.textContent = `${name} …`;
    try {
      const answer = await fetch('/presses', { method: 'POST', headers: { Authorization: `Bearer ${token}` }, body: button.dataset.press });
      const sent = stops ? `${name} is sent: watch the robot` : `${name}: sent`;
      answered.textContent = answer.ok ? sent : await answer.text() || answer.statusText;
    } catch {
      answered.textContent = `${name} is not sent: the server of this page does not answer`;
    }
  };

  const show = () => {
    bar.hidden = !data.running;
    document.documentElement.toggleAttribute('data-acts', Boolean(token) && data.running);
  };

  buttons.forEach((button) => { button.hidden = !token; });
  document.addEventListener('click', (event) => {
    const button = event.target.closest('[data-press]');
    if (button && token && data.running) press(button);
  });
  if (!token) answered.textContent = 'You watch. To act, open the address that the run printed, with all that follows the #.';
  addEventListener('hashchange', () => location.reload());
  shown.on('data', show);
  show();
};

startActing();
